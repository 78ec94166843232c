"""The campaigns that can be gone on with."""

from textual.content import Content
from textual.widgets import OptionList
from textual.widgets.option_list import Option

from station.guide.setup_view import UnfinishedCampaign

WORDS = {"free": "▶ go on: Enter", "in use": "✗ in use elsewhere", "not here": "✗ its folder is not here"}


class UnfinishedList(OptionList):
    """A line each; those that cannot be gone on with are shown and cannot be chosen."""

    DEFAULT_CSS = """
    UnfinishedList { height: auto; max-height: 3; margin: 0 2; border: none; }
    UnfinishedList:focus { border: none; }
    """

    def __init__(self) -> None:
        super().__init__(compact=True, id="unfinished", markup=False)
        self.campaigns: tuple[UnfinishedCampaign, ...] = ()

    def offer(self, campaigns: tuple[UnfinishedCampaign, ...]) -> None:
        """Offer other campaigns."""
        if campaigns == self.campaigns:
            return
        self.campaigns = campaigns
        self.display = bool(campaigns)
        self.set_options(Option(_line(c), disabled=c.state != "free") for c in campaigns)
        self.highlighted = next((i for i, c in enumerate(campaigns) if c.state == "free"), None)

    @property
    def is_of_use(self) -> bool:
        """Whether there is one to go on with."""
        return any(campaign.state == "free" for campaign in self.campaigns)


def _line(campaign: UnfinishedCampaign) -> Content:
    return Content.assemble(f"{campaign.title:50} ", WORDS[campaign.state])
