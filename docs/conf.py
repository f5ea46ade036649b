# SPDX-License-Identifier: GPL-3.0-or-later
"""The site of docs/, by Sphinx and MyST: deploy/site builds it."""
import os

project = "Mote"
author = "The Mote authors"
copyright = "the Mote authors, GPL-3.0-or-later"  # pylint: disable=redefined-builtin
release = version = os.environ.get("MOTE_VERSION", "")
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
master_doc = "index"
exclude_patterns = ["pictures"]
html_theme = "furo"
html_title = "Mote"
html_show_sphinx = False
html_copy_source = False
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
pygments_style = "friendly"
pygments_dark_style = "monokai"
# Blocks of JSON in these pages may have "..." in place of what is left out.
highlight_options = {"stripall": True}
