"""Scene files (TOML) to scenes."""
