"""Sentences on results, each made from values in the module of its subject; and tables of text."""
