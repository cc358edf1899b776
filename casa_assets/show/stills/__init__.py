"""Pictures of assets: stills, raw models, contact sheets, turntables."""
