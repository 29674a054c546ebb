"""A run is followed while it goes on: its record's messages, by whom has the token, on this machine alone."""
