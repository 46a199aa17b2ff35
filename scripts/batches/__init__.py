"""Batches of whole missions: scenarios, shapes and methods on the same random starts, compared in one table."""
