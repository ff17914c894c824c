"""Parameter studies: many runs of one scenario with other values, by processes here or on a cluster."""
