"""Borders drawn by a person and the rooms that they give (§3.1.1), without any page."""
