"""What the page is about, without a browser."""
