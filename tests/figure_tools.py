"""Functions with which tests read labels and curves of a figure."""

from matplotlib.axes import Axes


def by_id(ax: Axes, gid: str):
    (found,) = [artist for artist in ax.get_children() if artist.get_gid() == gid]
    return found


def legend_of(ax: Axes) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]
