"""The study: how a base model adapts to targets that differ from its simulator, as cases, contestants and a sweep."""
