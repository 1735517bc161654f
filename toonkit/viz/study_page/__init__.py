"""The study dashboard: what it knows, and what it draws."""
