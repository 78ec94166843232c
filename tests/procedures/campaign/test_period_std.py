"""What stamps leave open of several campaigns' time base."""

from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site, period_std


def test_it_is_that_of_the_worst() -> None:
    campaigns = [
        Campaign(
            "M", "S", True, Site(0.8, 9.8, 1e-5), (), (), ProcedureSigma(1e-3, 1e-4), Fixture(), period_std=std
        )
        for std in (1e-6, 3e-5, 2e-6)
    ]
    assert period_std(campaigns) == 3e-5
