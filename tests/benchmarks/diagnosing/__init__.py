"""Campaigns with effects planted in them that nobody declares, and how well a diagnosis names them."""
