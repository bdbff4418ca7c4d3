"""Text of the pages of the documentation that follow from the code, as Markdown. Nothing here needs Sphinx."""
