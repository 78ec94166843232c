"""What a plan is made of, from limits, the unit's recordings and the station's campaigns, and how it is said."""
