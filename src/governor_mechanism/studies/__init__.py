"""Questions that many runs of a scene answer: pure functions that return arrays; `render` draws them."""
