"""One module per table; each declares what it reads with :func:`paper.products.table`."""
