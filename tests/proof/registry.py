"""Every proof: a new one is a function ``proof(size, seed)`` in `tests.benchmarks`, and an entry here."""

from tests.proof.evidence import Proof

PROOFS = {proof.name: proof for proof in (
    # what a number means
    Proof("coverage", "coverage", "95 % intervals of a calibration hold the truth in 95 % of campaigns.",
          "campaigns", 1000, 40),
    Proof("budget", "budget", "The uncertainty budget is the scatter of whole campaigns that are drawn again.",
          "campaigns of each kind", 1000, 24),
    # what is named
    Proof("diagnosis", "diagnosis_scoreboard",
          "Causes have probabilities that are true, in the catalogue and outside it.", "planted worlds", 1000, 8),
    Proof("undeclared", "undeclared", "Error terms of no catalogue are reported as unexplained, and searched for.",
          "campaigns of each law and each good instrument", 20, 1),
    # what was accepted
    Proof("kills", "kills", "No kill of the program loses or doubles an accepted step.", "kills", 200, 12),
    Proof("power-cuts", "power_cuts.trial", "No power cut loses or doubles what was accepted.",
          "states of the disk", 100_000, 600),
    Proof("failing-disk", "failing_disks:proof_failing",
          "A disk that fails at any call is refused in one line, and nothing accepted is lost.",
          "calls from one failure to the next", 1, 9),
    Proof("slow-disk", "failing_disks:proof_slow", "A slow disk loses no accepted step and no sample.",
          "hundredths of a second for each change", 100, 5),
    Proof("two-writers", "two_writers", "Two stations on one database lose and cross nothing.",
          "transactions of each", 10_000, 200),
    Proof("false-accept", "false_accept", "The position that is asked for is the position that is in.",
          "dwells", 10_000, 140),
    Proof("year", "tests.proof.suites:year",
          "A simulated year of guided campaigns, whatever goes wrong, leaves no wrong result.",
          "campaigns", 1000, 8),
    # what the guide sees
    Proof("heading", "guiding:proof_heading", "A heading that is found by the Earth rate is right.",
          "trials of each case", 1000, 100),
    Proof("seating", "guiding:proof_seating", "A cube that stands tilted is detected, a clean one is not accused.",
          "campaigns", 60, 4),
    # who may change what
    Proof("mutations", "mutations", "A changed byte of a recording, an export or a calibration is found.",
          "changes", 10_000, 300),
    Proof("database-edits", "database_edits", "Every change of any table past the station is found.",
          "edits", 5000, 200),
    Proof("certificate-edits", "certificate_edits", "Every edit of a signed certificate is found.",
          "edits", 10_000, 320),
    # what a line or a file may send
    Proof("hostile-frames", "hostile_frames", "No damaged frame becomes data beyond what its check lets through.",
          "damaged frames of each format", 1_000_000, 20_000),
    Proof("hostile-mavlink", "hostile_mavlink",
          "No damaged MAVLink frame becomes data beyond what its CRC lets through.",
          "damaged frames", 1_000_000, 50_000),
    Proof("hostile-slcan", "hostile_slcan", "No damaged CAN line becomes data beyond what CRC-8 lets through.",
          "damaged lines", 1_000_000, 20_000),
    Proof("hostile-camera", "hostile_camera",
          "No damaged part of a camera's stream becomes an image of a wrong length.",
          "damaged parts", 100_000, 3000),
    Proof("hostile-values", "hostile_values",
          "Any value in any file handed in gives a result or one line.",
          "files of each kind", 1000, 60),
    # live
    Proof("replug", "replug", "A device that is unplugged and plugged in again is back, its gap marked.",
          "times", 100, 10),
    Proof("frozen", "frozen_screen", "A station that is frozen for 5 s at 1 kHz loses no frame.", "times", 5, 1),
    # compared with peers
    Proof("attitude", "attitude", "Roll and pitch compared with vqf, imufusion and ahrs on the same logs.",
          "simulated drives of each kind", 10, 1),
    Proof("locate", "locate", "Positions on recordings of drones, GNSS drawn from their truth.",
          "draws of each recording", 10, 1),
    Proof("kitti", "kitti", "Positions of a car at the GNSS fixes that were held out.",
          "fixes from one used to the next", 10, 10),
    Proof("speed", "speed", "Decoders and filters in the time of a peer, in the same process.",
          "frames", 40_000, 20_000),
    # tests marked as proofs
    Proof("marked", "tests.proof.suites:marked", "The tests that are marked as proofs pass.", "processes", 2, 1),
)}  # fmt: skip
