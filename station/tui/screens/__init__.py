"""Which screen shows which stage; a line here puts a screen into use."""

from collections.abc import Iterator, Mapping
from importlib import import_module

from station.guide.view import StageName
from station.tui.screens.stage import StageScreen

_HOMES: dict[StageName, str] = {
    "start": "start.StartScreen",
    "connecting": "connecting.ConnectingScreen",
    "warm_up": "warm_up.WarmUpScreen",
    "place": "campaign.CampaignScreen",
    "settle": "campaign.CampaignScreen",
    "dwell": "campaign.CampaignScreen",
    "turn": "campaign.CampaignScreen",
    "paused": "campaign.CampaignScreen",
    "solving": "solving.SolvingScreen",
    "verdict": "verdict.VerdictScreen",
    "stored": "verdict.VerdictScreen",
    "cancelled": "ended.EndedScreen",
    "left": "ended.EndedScreen",
    "failed": "ended.EndedScreen",
}


class _Screens(Mapping[StageName, type[StageScreen]]):
    """The screens by stage, each imported when it is first shown: the first one need not wait for the others."""

    def __getitem__(self, stage: StageName) -> type[StageScreen]:
        module, _, name = _HOMES[stage].partition(".")
        screen: type[StageScreen] = getattr(import_module(f"{__name__}.{module}"), name)
        return screen

    def __iter__(self) -> Iterator[StageName]:
        return iter(_HOMES)

    def __len__(self) -> int:
        return len(_HOMES)


SCREEN_FOR = _Screens()
