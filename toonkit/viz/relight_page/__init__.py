"""The relighting dashboard: what it knows, and the view that follows the dragged light."""
