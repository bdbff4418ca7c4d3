"""
A page that moves
=================

One HTML file without a server: the run under the pointer, with plots and forces.
"""

import governor_mechanism as gm

gm.film(gm.run("hartung_corrected"), "hartung.html")

# %%
# More: :doc:`films and pages </how_to/film>`.
