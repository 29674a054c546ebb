"""A slider on a board behind a serial line: the protocol, and how its axis joins those on the bus."""
