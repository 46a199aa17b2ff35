"""Plane geometry that robots and mission computer share: closed contours and integrals along them."""
