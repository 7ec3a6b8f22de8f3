"""Stand-in: events of nodes."""
