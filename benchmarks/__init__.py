"""What Hognose's speed claims are measured with: `make bench`."""
