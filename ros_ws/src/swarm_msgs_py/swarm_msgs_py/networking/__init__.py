"""Whom can a node reach, and through whom: neighbours, DSDV routes, delivery over the mesh."""
