"""Work-precision study: error and time of every engine over its settings."""
