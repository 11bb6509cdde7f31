"""One module per figure, or per figures of one kind; each declares what it reads with :func:`paper.products.figure`."""
