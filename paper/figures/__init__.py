"""One module per figure or group of similar figures; each declares what it reads with :func:`paper.products.figure`."""
