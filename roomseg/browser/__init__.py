"""Maps on a page of their own, to be looked at in a browser (Bokeh)."""
