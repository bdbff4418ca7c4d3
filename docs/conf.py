"""Configuration of the documentation, built by `make docs`.

Sphinx, because it checks every cross-reference and anchor and can treat a broken one as an error, makes the reference of the Python API
from numpydoc docstrings, and lets a short extension write formulas as MathML, so that pages need no script, font or style from the network.
MkDocs with its Material theme, the usual alternative, is in maintenance mode.
"""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / folder) for folder in ("extensions", "pictures", "questions")]

import governor_mechanism  # noqa: E402
from made_from import EXAMPLES, digest_drawing, is_made_from  # noqa: E402

project = "governor_mechanism"
author = "The governor_mechanism authors"
version = release = governor_mechanism.__version__
language = "en"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.githubpages",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "generated_pages",
    "picture_sizes",
    "mathml",
    "navigation",
    "references",
]
exclude_patterns = ["_build", "_generated/*.md", "_generated/site", "_generated/examples/**/*.ipynb", "examples", "README.md"]
nitpicky = True
suppress_warnings = ["config.cache"]

# Markdown
myst_enable_extensions = ["dollarmath", "deflist"]
smartquotes = False  # quotes in descriptions of keys are part of what one types
myst_heading_anchors = 4
nb_execution_mode = "cache"  # a notebook is run when it has changed, and shown with what its cells print and draw
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_ipywidgets_js = {}  # which would come from the network: `gm.explore` shows a picture instead
nb_mime_priority_overrides = [("html", "application/vnd.jupyter.widget-view+json", None)]
html_math_renderer = "mathml"

# Examples: docs/examples/ is run, and shown with its output and pictures. A button copies a piece of code without its prompt.
EXAMPLE_GROUPS = ["linkages", "governors", "engines", "studies", "trust", "export"]
sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "_generated/examples",
    "filename_pattern": r"\.py$",
    "subsection_order": [f"examples/{group}" for group in EXAMPLE_GROUPS],
    "image_scrapers": ("example_pictures.collect_pictures",),
    "reset_modules": ("matplotlib",),
    "capture_repr": (),
    "default_thumb_file": str(HERE / "static" / "governor.svg"),
    "abort_on_example_error": True,
    "run_stale_examples": not is_made_from(EXAMPLES, digest_drawing()),  # else those that have changed
    "backreferences_dir": "_generated/examples/of",
    "doc_module": ("governor_mechanism",),
    "download_all_examples": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,  # none: the machine that builds the pages is nobody's measure
    "show_signature": False,
}
copybutton_prompt_text = "$ "
copybutton_selector = "div.highlight:not(.cell_output *, .sphx-glr-script-out *) pre"  # code, not what it prints

# Python API: types stand in annotations, so they are shown with the parameters.
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = False  # the options of films stand in the signature of `film`, not in its source
autodoc_class_signature = "mixed"
napoleon_google_docstring = False
napoleon_use_rtype = True
napoleon_use_ivar = True
napoleon_attr_annotations = True
default_role = "code"  # of a docstring: `name`
python_use_unqualified_type_names = True
toc_object_entries_show_parents = "hide"
add_module_names = False

# Pages
html_theme = "pydata_sphinx_theme"
html_title = "governor_mechanism"
html_static_path = ["static"]
html_favicon = "static/governor.svg"
html_context = {"default_mode": "auto"}
html_css_files = ["style.css"]
html_extra_path = ["_generated/site"]
html_show_sourcelink = False
html_copy_source = False
html_show_sphinx = False
html_sidebars: dict[str, list[str]] = {"index": [], "gallery": [], "glossary": [], "errata/index": []}  # they have no pages below them
html_theme_options = {
    "logo": {"text": "governor_mechanism", "image_light": "static/governor.svg", "image_dark": "static/governor_dark.svg", "alt_text": ""},
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "header_links_before_dropdown": 8,
    "navigation_depth": 3,
    "show_nav_level": 1,
    "show_toc_level": 1,
    "secondary_sidebar_items": {"**": ["page-toc"], "index": [], "gallery": []},
    "navigation_with_keys": False,
    "back_to_top_button": False,
    "footer_start": [],
    "footer_end": ["copyright"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
(HERE / "_generated" / "site").mkdir(parents=True, exist_ok=True)  # the interactive pages, which `generated_pages` makes
