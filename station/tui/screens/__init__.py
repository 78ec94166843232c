"""Which screen shows which stage; a line here puts a screen into use."""

from station.guide.view import Stage
from station.tui.screens.campaign import CampaignScreen
from station.tui.screens.connecting import ConnectingScreen
from station.tui.screens.ended import EndedScreen
from station.tui.screens.solving import SolvingScreen
from station.tui.screens.stage import StageScreen
from station.tui.screens.start import StartScreen
from station.tui.screens.verdict import VerdictScreen
from station.tui.screens.warm_up import WarmUpScreen

SCREEN_FOR: dict[Stage, type[StageScreen]] = {
    "start": StartScreen,
    "connecting": ConnectingScreen,
    "warm_up": WarmUpScreen,
    "place": CampaignScreen,
    "settle": CampaignScreen,
    "dwell": CampaignScreen,
    "turn": CampaignScreen,
    "paused": CampaignScreen,
    "solving": SolvingScreen,
    "verdict": VerdictScreen,
    "stored": VerdictScreen,
    "cancelled": EndedScreen,
    "left": EndedScreen,
    "failed": EndedScreen,
}
