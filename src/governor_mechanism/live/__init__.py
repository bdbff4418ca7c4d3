"""A mechanism under the hand: a page in the browser whose changes the real engines answer."""
