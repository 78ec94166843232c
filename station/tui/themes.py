"""How it looks: a calm dark theme, and one of high contrast."""

from textual.theme import Theme

OURS = {  # colours that no theme of Textual's has; the axes are red, green and blue
    "axis-x": "#ff6b6b",
    "axis-y": "#5fd38d",
    "axis-z": "#5aa9ff",
    "muted": "#8a99a8",
    "sky": "#1f5a8c",
    "ground": "#5c4326",
}

STATION = Theme(
    name="station",
    primary="#4aa3df",
    secondary="#2f6f9f",
    accent="#ffb454",
    warning="#ffb454",
    error="#ff6b6b",
    success="#5fd38d",
    foreground="#dde5ec",
    background="#10161d",
    surface="#18212b",
    panel="#202c38",
    variables=OURS,
)
HIGH_CONTRAST = Theme(
    name="high-contrast",
    primary="#00d7ff",
    secondary="#00afd7",
    accent="#ffff00",
    warning="#ffff00",
    error="#ff5f5f",
    success="#00ff5f",
    foreground="#ffffff",
    background="#000000",
    surface="#000000",
    panel="#1c1c1c",
    text_alpha=1.0,
    variables={
        "axis-x": "#ff5f5f",
        "axis-y": "#00ff5f",
        "axis-z": "#5fafff",
        "muted": "#ffffff",
        "sky": "#0000af",
        "ground": "#5f3700",
    },
)
