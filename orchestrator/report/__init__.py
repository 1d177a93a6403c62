"""One self-contained page of figures and tables."""
