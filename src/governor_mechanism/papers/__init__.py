"""The four papers: what is not right in them, and whether their rules about governing hold. The rest of the package does without."""
