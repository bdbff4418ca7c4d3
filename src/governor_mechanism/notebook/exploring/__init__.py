"""A view with sliders: dimensions and a speed or a position are dragged, and curve and drawing follow."""
