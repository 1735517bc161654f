"""Layered documents (PSD, ORA, KRA, folders of pictures): their merged picture, and their layers."""
