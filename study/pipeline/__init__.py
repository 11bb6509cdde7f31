"""What connects experiments to files: options, products, commands, configuration."""
