"""Films and figures of runs. No folder before `render` imports it."""
