"""Studies over many runs of a scene. They return arrays; `render` draws them."""
