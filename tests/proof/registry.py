"""Every proof: a line each. A new one is a function ``proof(size, seed)`` that returns numbers, and a line here."""

from tests.proof.evidence import Proof

B = "tests.benchmarks"

# name, function, what it shows, what its size counts, size, quick size
PROOFS = {
    proof.name: proof
    for proof in (
        # What a number means
        Proof("coverage", f"{B}.coverage", "95 % intervals of a calibration hold the truth in 95 % of campaigns.",
              "campaigns", 1000, 40),
        Proof("budget", f"{B}.budget", "The uncertainty budget is the scatter of whole campaigns that are drawn anew.",
              "campaigns of each kind", 1000, 40),
        Proof("paper", f"{B}.paper", "The biases of tables 4 to 6 of Yao, Hu, He 2018 come out of integer counts.",
              "campaigns", 200, 20),
        Proof("count-rate", f"{B}.count_rate", "The rate of a dwell is as good as its noise allows, and its u is honest.",
              "dwells of each noise and rate", 480, 24),
        Proof("clock-rate", f"{B}.clock_rate", "The rate of the unit's clock is honest on a loaded machine.",
              "campaigns at each load", 200, 20),
        Proof("history", f"{B}.history", "Predictions and control charts of a unit's history are as sure as they say.",
              "units", 400, 60),
        # What is named
        Proof("diagnosis", f"{B}.diagnosis", "Error terms of the catalogue are named, and nothing is made up.",
              "campaigns of each kind", 50, 1),
        Proof("undeclared", f"{B}.undeclared", "Error terms of no catalogue are reported as unexplained.",
              "campaigns of each kind", 20, 1),
        Proof("discovery", f"{B}.discovery", "The search for terms finds laws outside the catalogue.",
              "campaigns of each law", 10, 1),
        # What was accepted
        Proof("kills", f"{B}.kills", "No kill of the program loses or doubles an accepted step.", "kills", 200, 12),
        Proof("power-cuts", f"{B}.power_cuts.trial", "No power cut loses or doubles what was accepted.",
              "states of the disk", 100_000, 600),
        Proof("failing-disk", f"{B}.failing_disks:proof_failing",
              "A disk that fails at any call is refused in one line, and nothing accepted is lost.",
              "calls from one failure to the next", 1, 9),
        Proof("slow-disk", f"{B}.failing_disks:proof_slow", "A slow disk loses no accepted step and no sample.",
              "hundredths of a second for each change", 100, 5),
        Proof("two-writers", f"{B}.two_writers", "Two stations on one database lose and cross nothing.",
              "transactions of each", 10_000, 200),
        Proof("false-accept", f"{B}.false_accept", "The position that is asked for is the position that is in.",
              "dwells", 10_000, 140),
        Proof("year", "tests.proof.suites:year",
              "A simulated year of guided campaigns, whatever goes wrong, leaves no wrong result.",
              "campaigns", 1000, 8),
        # What the guide sees
        Proof("heading", f"{B}.guiding:proof_heading", "A heading that is found by the Earth rate is right.",
              "trials of each case", 1000, 100),
        Proof("seating", f"{B}.guiding:proof_seating", "A cube that stands tilted is detected, a clean one is not accused.",
              "campaigns", 60, 4),
        Proof("closing", f"{B}.guiding:proof_closing", "A turn that did not close is asked for again.",
              "pairs of turns", 1200, 60),
        # Who may change what
        Proof("mutations", f"{B}.mutations", "A changed byte of a recording, an export or a calibration is found.",
              "changes", 10_000, 300),
        Proof("database-edits", f"{B}.database_edits", "Every change of any table past the station is found.",
              "edits", 5000, 200),
        Proof("certificate-edits", f"{B}.certificate_edits", "Every edit of a signed certificate is found.",
              "edits", 10_000, 320),
        # What a line or a file may send
        Proof("hostile-frames", f"{B}.hostile_frames", "No damaged frame becomes data beyond what its check lets through.",
              "damaged frames of each format", 1_000_000, 20_000),
        Proof("hostile-mavlink", f"{B}.hostile_mavlink", "The same of MAVLink.", "damaged frames", 1_000_000, 50_000),
        Proof("hostile-slcan", f"{B}.hostile_slcan", "The same of CAN over slcan.", "damaged lines", 1_000_000, 20_000),
        Proof("hostile-camera", f"{B}.hostile_camera", "The same of images of a camera.", "damaged parts", 100_000, 3000),
        Proof("hostile-values", f"{B}.hostile_values.__main__",
              "Any value in any file handed in gives a result or one line.", "files of each kind", 1000, 60),
        # Live
        Proof("replug", f"{B}.replug", "A device that is unplugged and plugged in again is back, its gap marked.",
              "times", 100, 10),
        Proof("frozen", f"{B}.frozen_screen", "A station that is frozen for 5 s at 1 kHz loses no frame.", "times", 5, 1),
        Proof("two-streams", f"{B}.two_streams", "An IMU of 2 kHz and a receiver are recorded without a loss.",
              "seconds", 600, 15),
        # Beside peers
        Proof("attitude", f"{B}.attitude", "Roll and pitch beside vqf, imufusion and ahrs on the same logs.",
              "simulated drives of each kind", 10, 1),
        Proof("locate", f"{B}.locate", "Positions on recordings of drones, GNSS drawn from their truth.",
              "draws of each recording", 10, 1),
        Proof("kitti", f"{B}.kitti", "Positions of a car at the fixes that were held out.", "fixes from one used to the next",
              10, 10),
        Proof("speed", f"{B}.speed", "Decoders and filters in the time of a peer, in the same process.",
              "frames", 40_000, 20_000),
        # Tests marked as proofs
        Proof("marked", "tests.proof.suites:marked", "The tests that are marked as proofs pass.", "processes", 2, 1),
    )
}  # fmt: skip
