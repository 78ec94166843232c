"""Files as the station reads and writes them.

`tables` reads any table of numbers; `logs` makes campaigns of tables from elsewhere; `campaign_folder` reads the
station's own campaigns, `mcap_files` their recordings, `fusion_folder` drives and flights. The files next to them
are one format each; `toml_file` reads all TOML, `atomic_file` writes everything.
"""
