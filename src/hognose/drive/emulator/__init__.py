"""Drives that exist only as a program: what they say on the bus, and how their motors move."""
