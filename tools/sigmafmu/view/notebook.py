"""What `Result.show()` gives to a notebook."""

from dataclasses import dataclass
from html import escape


@dataclass(frozen=True)
class Shown:
    """A page within a frame of `height` pixels; notebooks display it."""

    page: str
    height: int

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe style="{style}" sandbox="allow-scripts" srcdoc="{escape(self.page)}"></iframe>'
