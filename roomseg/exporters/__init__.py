"""Maps in the formats of other programs; each module makes what is written, of arrays."""
