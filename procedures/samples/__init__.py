"""What acts sample by sample while a recording rests or turns evenly: it averages out of the rows of evidence.

`held_samples` are the samples, `sample_blocks` cuts them into blocks; periodic errors (`sample_phases`,
`sample_turns`), lines (`sample_lines`), rectification and `channel_noise` are found on these;
`sample_effects` runs them all.
"""
