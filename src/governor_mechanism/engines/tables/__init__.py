"""The compiled core of the engine `reduced`: one coordinate along laid pieces, its forces, steps, events."""
