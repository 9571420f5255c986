// Starts Swagger UI; a file of its own, since the page's policy admits no script inside it.
SwaggerUIBundle({
  url: "openapi.json",
  dom_id: "#page",
  deepLinking: true,
  tryItOutEnabled: true,
  defaultModelExpandDepth: 2,
  defaultModelsExpandDepth: 0,
  docExpansion: "list",
  displayRequestDuration: true,
  filter: true,
  showExtensions: false,
  syntaxHighlight: false, // it colours a spacecraft's plan for 70 s, in which the page stands still
  // Only the text is shown; what it was parsed into would be copied value by value.
  responseInterceptor: (response) => Object.assign(response, { obj: undefined, body: undefined }),
  validatorUrl: null, // else the page asks an outside service to judge the document
  presets: [SwaggerUIBundle.presets.apis, SwaggerUIBundle.SwaggerUIStandalonePreset],
});
