"""The paper's figures, each drawn into given axes from arrays (Matplotlib, no global state)."""

from roomseg.figures.camera_images import (
    draw_camera_image,
    draw_edge_pixels,
    draw_lintel_histogram,
    draw_lintel_search,
    draw_panorama,
)
from roomseg.figures.charts import (
    RocCurve,
    draw_border_share,
    draw_impurity_bars,
    draw_impurity_surface,
    draw_lines,
    draw_passage_width,
    draw_roc,
    draw_room_counts,
)
from roomseg.figures.contact_sheet import contact_sheet_figure
from roomseg.figures.graphs import draw_borders, draw_graph, draw_rooms, match_rooms, wrong_nodes
from roomseg.figures.legend import add_map_legend
from roomseg.figures.plan import (
    HomePlan,
    PlanDoor,
    PlanRoom,
    PlanWindow,
    Symbol,
    home_plan_figure,
)
from roomseg.figures.plans import (
    Plan,
    draw_cleaning_run,
    draw_floor,
    draw_obstacle_map,
    draw_outlines,
)
from roomseg.figures.sheet import Chart, SheetPlace, dataset_sheet
from roomseg.figures.style import figure_bytes, finish_plan, new_figure, png_bytes, scale_bar

__all__ = [
    "Chart",
    "HomePlan",
    "Plan",
    "PlanDoor",
    "PlanRoom",
    "PlanWindow",
    "RocCurve",
    "SheetPlace",
    "Symbol",
    "add_map_legend",
    "contact_sheet_figure",
    "dataset_sheet",
    "draw_border_share",
    "draw_borders",
    "draw_camera_image",
    "draw_cleaning_run",
    "draw_edge_pixels",
    "draw_floor",
    "draw_graph",
    "draw_impurity_bars",
    "draw_impurity_surface",
    "draw_lines",
    "draw_lintel_histogram",
    "draw_lintel_search",
    "draw_obstacle_map",
    "draw_outlines",
    "draw_panorama",
    "draw_passage_width",
    "draw_roc",
    "draw_room_counts",
    "draw_rooms",
    "figure_bytes",
    "finish_plan",
    "home_plan_figure",
    "match_rooms",
    "new_figure",
    "png_bytes",
    "scale_bar",
    "wrong_nodes",
]
