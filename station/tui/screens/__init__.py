"""Which screen shows which stage; a line here puts a screen into use.

`start` sets a campaign up, `campaign` shows its steps, `verdict` its end; `modals` lie on top of them. All are
made of the widgets of `station.tui.widgets` in the frame of `framed_screen`.
"""

from importlib import import_module

from station.guide.view import StageName
from station.tui.screens.framed_screen import StageScreen

SCREENS: dict[StageName, str] = {
    "start": "start.StartScreen",
    "connecting": "framed_screen.WaitingScreen",
    "warm_up": "campaign.WarmUpScreen",
    "place": "campaign.CampaignScreen",
    "settle": "campaign.CampaignScreen",
    "dwell": "campaign.CampaignScreen",
    "turn": "campaign.CampaignScreen",
    "paused": "campaign.CampaignScreen",
    "solving": "framed_screen.WaitingScreen",
    "verdict": "verdict.VerdictScreen",
    "stored": "verdict.VerdictScreen",
    "cancelled": "verdict.EndedScreen",
    "left": "verdict.EndedScreen",
    "failed": "verdict.EndedScreen",
}


def screen_for(stage: StageName) -> type[StageScreen]:
    """Return a stage's screen, imported when it is first shown: the first one need not wait for the others."""
    module, _, name = SCREENS[stage].partition(".")
    screen: type[StageScreen] = getattr(import_module(f"{__name__}.{module}"), name)
    return screen
