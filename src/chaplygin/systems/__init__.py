"""The systems that scenes name: parameters and initial states from TOML, problems to integrate.

One file a system, or a family of closely related ones; what they share is in `parameters` and
`models`. Every system offers all representations that are valid for the initial state: the scene's
own first, those that carry the attitude g last (unless the scene asks for the attitude).
"""
