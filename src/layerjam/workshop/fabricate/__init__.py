"""Manufacture: film patterns, printed parts, a mould, a parts list, and checks of the build."""
