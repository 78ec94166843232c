"""A guided calibration in this process, with nobody to ask: what the counts show decides."""

from collections.abc import Callable
from dataclasses import replace

from fixtures_db.database import Database
from station.files.campaign_setup import Setup
from station.guide.campaign.campaign_start import begin
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions, EngineOptions
from station.guide.simulated_operator import HandsLost, SimulatedOperator
from station.guide.view import ENDED_STAGES, VERDICT_STAGES, CalibrationView, OperatorCommand
from station.stream.live.live_feed import REPLUG_S


def run_headless(
    options: EngineOptions, database: Database, show: Callable[[CalibrationView], None], *, stores: bool
) -> CalibrationView:
    """Do ``options.first`` up to a verdict and, if asked, store the calibration; return the last view.

    Raises
    ------
    DriverError, CannotWrite, DataRefused, ProcedureError, DatabaseError
        What ended it; every accepted step stays.
    """
    engine = CalibrationEngine(database, replace(options.engine(), is_patient=False), show)
    operator = options.operator()
    try:
        if options.first is not None:
            engine.execute(options.first)
        while engine.view.stage not in ENDED_STAGES | VERDICT_STAGES:
            engine.round()
            show(engine.view)
            if operator:
                look(operator, engine.view)
        if stores:
            engine.execute(OperatorCommand(verb="store"))
            show(engine.view)
        return engine.view
    finally:
        engine.close()


def record_headless(
    setup: Setup,
    options: CalibrationOptions,
    database: Database,
    operator: SimulatedOperator,
    show: Callable[[CalibrationView], None],
) -> None:
    """Record a new campaign, without solving it; raises as `run_headless`."""
    campaign = begin(setup, database, options)
    try:
        while not campaign.guide.is_complete:
            campaign.round()
            view = campaign.view(CalibrationView())
            show(view)
            look(operator, view)
    finally:
        campaign.close()


def look(operator: SimulatedOperator, view: CalibrationView) -> None:
    """Show the view to the simulated operator; raise `HandsLost` if the hands stay away longer than a port may."""
    operator.look(view)
    if operator.lost_s > REPLUG_S:
        raise HandsLost(operator.lost)
