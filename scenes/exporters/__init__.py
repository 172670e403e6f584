"""Apartments in the formats of others: ``write_<format>(apartment, path, **options)``."""
