"""Campaign folders (`campaign/1`): what a station records and what anyone may bring from elsewhere.

`campaign_schema` declares the keys of ``campaign.toml``; `campaign_reading` reads tables and data files
(`sample_series`), checks them (`step_consistency`) and gives a `loaded_campaign`. `plan_file` holds what a guided
campaign keeps besides.
"""
