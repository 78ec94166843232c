"""Roll and pitch online: the mixing law of P2, its velocity aids, and the joint filter that is the default.

P2 is You, Lee, an accelerometer-aided mixing algorithm for strapdown roll and pitch. Body axes are
forward-right-down, the level frame north-east-down (``forward_right_down.py``); attitude is carried as the *down
vector*, the unit vector of gravity in body axes, which has no singularity. Physics and measured figures:
``docs/attitude.md``.
"""
