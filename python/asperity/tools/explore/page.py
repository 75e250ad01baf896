"""The page: sliders, figures and texts of Bokeh, whose server answers every move of a slider."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from bokeh import models
from bokeh.document import Document
from bokeh.layouts import column, row
from bokeh.models.annotations import ColorBar
from bokeh.models.layouts import Column
from bokeh.models.widgets.buttons import Button
from bokeh.models.widgets.groups import RadioButtonGroup
from bokeh.models.widgets.inputs import Select
from bokeh.models.widgets.markups import Div, PreText
from bokeh.models.widgets.sliders import Slider
from bokeh.palettes import Cividis256
from bokeh.plotting import figure
from bokeh.transform import transform

from ...contract import Floats
from ..fit.model import MATERIAL
from . import model

BLUE, ORANGE, LOWER, UPPER = "#0072B2", "#D55E00", "#BBBBBB", "#DDDDDD"

GROUPS = {
    "Material": MATERIAL,
    "Pattern": ("sides", "theta", "flat"),
    "Load path": ("direction", "sigma_N", "slip"),
}
"""Sliders under their headings."""

COPY = """
navigator.clipboard.writeText(text.text);
button.label = "copied";
setTimeout(() => { button.label = "copy"; }, 1000);
"""
"""Copy in the browser, to whose clipboard a page of this machine has access."""


class Page:
    """Widgets of one open page, and what they do."""

    def __init__(self, document: Document, values: Mapping[str, float]) -> None:
        """Build the page with the values at the start."""
        self.document = document
        self.waiting = False
        self.answer: model.Answer | None = None
        self.sliders = {name: _slider(name, value) for name, value in values.items()}
        cycles: list[str | tuple[Any, str]] = [*model.CYCLES]
        self.cycle = Select(title="cycle", value="one cycle", options=cycles, name="cycle")
        self.place = Slider(
            title="position on the path [%]", start=0, end=100, step=1, value=100, name="position"
        )
        self.kind = RadioButtonGroup(labels=list(model.TEXTS), active=0, name="kind")
        self.text = PreText(
            name="text", width=335, styles={"font-size": "11px"}, stylesheets=["pre {white-space: pre-wrap}"]
        )
        self.copy = Button(label="copy", width=80, name="copy")
        self.copy.js_on_event(
            "button_click", models.CustomJS(args={"text": self.text, "button": self.copy}, code=COPY)
        )
        self.message = Div(name="message", sizing_mode="stretch_width")
        names = ("slip", "tau", "s_N", "damage")
        self.curves, self.here = _source("curves", *names), _source("here", *names)
        self.planes = _source("planes", "xs", "ys", "alpha")
        self.section = _source("section", "xs", "ys", "colour")
        self.touching, self.arrow = _source("touching", "x", "y"), _source("arrow", "x", "y")
        self.shown = (self.here, self.planes, self.touching, self.section, self.arrow)
        for slider in self.sliders.values():
            slider.on_change("value", self._changed)
        self.cycle.on_change("value", self._changed)
        self.place.on_change("value", lambda attr, old, new: self._show_place())
        self.kind.on_change("active", lambda attr, old, new: self._show_text())
        document.title = "asperity explore"
        document.add_root(self._layout())
        self.redraw()

    @property
    def choice(self) -> model.Choice:
        """Values of the sliders."""
        values = {name: float(slider.value) for name, slider in self.sliders.items()}
        for name in model.LOGARITHMIC:
            lowest = name in model.OPTIONAL and values[name] <= self.sliders[name].start
            # four digits, as the slider shows them
            values[name] = 0.0 if lowest else float(f"{10.0 ** values[name]:.4g}")
        return model.Choice(values, self.cycle.value)

    def _changed(self, attr: str, old: object, new: object) -> None:
        """Redraw once for all changes that came together."""
        if not self.waiting:
            self.waiting = True
            self.document.add_next_tick_callback(self.redraw)

    def redraw(self) -> None:
        """Compute the choice and show it, or the message of the library."""
        self.waiting = False
        self.document.hold("combine")
        choice = self.choice
        try:
            self.answer = model.answer(choice)
        except ValueError as error:
            self.answer = None
            self._say("error", [str(error)])
            _clear(self.curves, *self.shown)
            self.text.text = ""
        else:
            answer = self.answer
            self._say("lost" if answer.lost else "warning", [*filter(None, [answer.lost]), *answer.warnings])
            self.curves.data = _rows(answer, slice(None))
            self._show_place()
            self._show_text()
        self.document.unhold()

    def _show_place(self) -> None:
        """Show planes and section at the position on the path."""
        answer = self.answer
        if answer is None or not len(answer.history):
            _clear(*self.shown)
            return
        history = answer.history
        at = round(0.01 * self.place.value * (len(history) - 1))
        self.here.data = _rows(answer, slice(at, at + 1))
        xs, ys = model.plan(answer.interface.pattern)
        alpha = [float(history.alpha(k + 1)[at]) for k in range(len(xs))]
        self.planes.data = {"xs": xs, "ys": ys, "alpha": alpha}
        closed = model.in_contact(answer, at)
        self.touching.data = {
            axis: [float(np.mean(part)) for part, yes in zip(parts, closed, strict=True) if yes]
            for axis, parts in (("x", xs), ("y", ys))
        }
        self.arrow.data = {"x": [0.0, 1.1 * answer.e[0]], "y": [0.0, 1.1 * answer.e[1]]}
        x, z, (slip, s_N) = model.section(answer, at)
        depth = 0.25 * float(x[-1] - x[0])
        top = float(z.max()) + depth
        lower = [[*x, x[-1], x[0]], [*z, -depth, -depth]]
        upper = [[*(x + slip), x[-1] + slip, x[0] + slip], [*(z + s_N), top + s_N, top + s_N]]
        sides = {axis: [upper[i], lower[i]] for i, axis in enumerate(("xs", "ys"))}
        self.section.data = sides | {"colour": [UPPER, LOWER]}

    def _show_text(self) -> None:
        if self.answer is not None:
            text_of = list(model.TEXTS.values())[self.kind.active or 0]
            self.text.text = text_of(self.answer.choice)

    def _say(self, kind: str, texts: list[str]) -> None:
        colour = {"error": "#B00020", "lost": "#B00020", "warning": "#555555"}[kind]
        lines = "<br>".join(html.escape(text) for text in texts)
        self.message.text = f'<div class="{kind}" style="color: {colour}">{lines}</div>'

    def _layout(self) -> Column:
        """Sliders at the left, figures at the right."""
        controls: list[Div | Slider | Select] = []
        for heading, names in GROUPS.items():
            controls += [Div(text=f"<b>{heading}</b>"), *(self.sliders[name] for name in names)]
        controls.append(self.cycle)
        figures = [
            self._curve("tau", "traction along the slip [MPa]"),
            self._curve("s_N", "dilation s_N [mm]"),
            self._curve("damage", "damage [-]"),
        ]
        text = column(row(self.kind, self.copy), self.text)
        # figures that have no room beside the others stand below them
        wrapped = {"flex-wrap": "wrap"}
        bottom = row(self._plan(), self._section(), text, styles=wrapped, sizing_mode="stretch_width")
        curves = row(*figures, styles=wrapped, sizing_mode="stretch_width")
        right = column(curves, self.place, bottom, sizing_mode="stretch_width")
        sliders = column(*controls, width=300, margin=(0, 0, 0, 8))
        page: Column = column(
            Div(text="<h2>A rough joint under pressure and slip</h2>"),
            self.message,
            row(sliders, right, sizing_mode="stretch_width"),
            sizing_mode="stretch_width",
        )
        return page

    def _curve(self, name: str, label: str) -> figure:
        tools, tips = "pan,wheel_zoom,box_zoom,reset,hover,save", [("slip", "@slip{0.0000}")]
        tips.append((name, f"@{name}{{0.0000}}"))
        plot = _figure(tools, height=300, x_axis_label="slip [mm]", y_axis_label=label, tooltips=tips)
        plot.line("slip", name, source=self.curves, color=BLUE, line_width=1.8)
        plot.scatter("slip", name, source=self.here, color=ORANGE, size=9)
        return plot

    def _plan(self) -> figure:
        plot = _figure("", match_aspect=True, title="planes from above, dots: the sides touch")
        colours = models.LinearColorMapper(palette=Cividis256, low=0.0, high=1.0)
        fill = transform("alpha", colours)
        plot.patches("xs", "ys", source=self.planes, line_color="white", line_width=2, fill_color=fill)
        plot.scatter("x", "y", source=self.touching, color="white", line_color="black", size=11)
        plot.line("x", "y", source=self.arrow, color=ORANGE, line_width=3)
        plot.axis.visible = False
        plot.grid.visible = False
        plot.add_layout(ColorBar(color_mapper=colours, title="damage", width=12), "right")
        return plot

    def _section(self) -> figure:
        title = "section along the slip, true to scale"
        plot = _figure("pan,wheel_zoom,reset", match_aspect=True, title=title)
        plot.xaxis.axis_label, plot.yaxis.axis_label = "along the slip [mm]", "N [mm]"
        plot.patches("xs", "ys", source=self.section, fill_color="colour", line_color="black")
        return plot


def _figure(tools: str, height: int = 330, **more: Any) -> figure:
    """Figure of the width of a column; without tools it has no bar of them."""
    place: Literal["above"] | None = "above" if tools else None
    return figure(width=335, height=height, tools=tools, toolbar_location=place, **more)


def _rows(answer: model.Answer, part: slice) -> dict[str, Floats]:
    history = answer.history
    columns = {"slip": answer.slip, "tau": answer.tau, "s_N": history.dilation, "damage": history.damage}
    return {name: values[part] for name, values in columns.items()}


def _slider(name: str, value: float) -> Slider:
    _, title, low, high, step = model.SLIDERS[name]
    more: dict[str, Any] = {"stylesheets": [".bk-slider-title {white-space: normal}"]}
    if name in model.LOGARITHMIC:
        value = float(np.log10(value)) if value > 0.0 else low
        number = "Number((10 ** tick).toPrecision(4)).toString()"
        none = f"tick <= {min(low, value)} ? '0' : " if name in model.OPTIONAL else ""
        more["format"] = models.CustomJSTickFormatter(code=f"return {none}{number}")
    elif step < 0.1:
        more["format"] = "0.000"
    start, end = min(low, value), max(high, value)
    return Slider(title=title, step=step, value=value, name=name, width=280, start=start, end=end, **more)


def _source(name: str, *columns: str) -> models.ColumnDataSource:
    return models.ColumnDataSource({column: [] for column in columns}, name=name)


def _clear(*sources: models.ColumnDataSource) -> None:
    for source in sources:
        source.data = {name: [] for name in source.data}
