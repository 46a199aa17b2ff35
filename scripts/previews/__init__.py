"""Looks at shapes before anything runs."""
